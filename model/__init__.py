"""The physics of fowtio: numpy and scipy only, frozen data in, data out. Import `fowtio`, which re-exports it."""
