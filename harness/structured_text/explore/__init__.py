"""The exploration of every reachable state of a program, with every choice of its environment.

`search` visits all states of a world, breadth first. `abstraction` encodes states of a program,
with the tables of a library in `omitted`. `shared` distributes the steps over several processors.
"""
