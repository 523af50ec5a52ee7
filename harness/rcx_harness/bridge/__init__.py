"""The bridge of `rcx bridge`: it connects a PLC with Modbus TCP and an EtherNet/IP controller."""
