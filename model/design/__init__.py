"""Design: what it must withstand, what it costs."""
