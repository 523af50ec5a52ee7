"""Fault campaigns: random long runs in which everything fails, again and again.

A program is driven while packets are lost, late and doubled, the packet interval changes, scans
overrun, PLC and controller lose their power; then the causes go. `station` is the cell, `storms`
runs what befalls it and makes a failing run short, `requests` compares what was asked for with
what was executed. What drives a program, and its way back, comes from who knows the program.
"""
