"""Links of the virtual cell over EtherNet/IP."""
