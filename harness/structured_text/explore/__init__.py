"""The exploration of all reachable states of a program, under all choices of its environment.

`search` visits all states of a world, breadth first. `abstraction` encodes states of a program,
with the tables of a library in `omitted`. `shared` distributes the steps over several processors.
"""
