"""The room of `rcx bridge`: it connects a Modbus TCP PLC to an EtherNet/IP controller."""
