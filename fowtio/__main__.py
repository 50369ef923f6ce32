"""`python -m fowtio` is the command line."""

from fowtio.cli import main

main()
