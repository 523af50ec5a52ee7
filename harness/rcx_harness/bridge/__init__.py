"""The bridge of `rcx bridge`. It connects a PLC with Modbus TCP to an EtherNet/IP controller."""
