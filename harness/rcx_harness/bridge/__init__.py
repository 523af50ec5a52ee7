"""`rcx bridge`: a PLC that speaks Modbus TCP drives a controller that speaks EtherNet/IP."""
