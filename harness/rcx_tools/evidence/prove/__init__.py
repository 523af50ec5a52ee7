"""What is proved of plc/lib, for every program: `make prove`."""
