"""Every reachable state of a program, with every choice of its environment.

`search` goes through all states of a world, breadth first; `abstraction` tells states of a program
apart, with what `kept` says of a library; `shared` takes the steps on many processors.
"""
