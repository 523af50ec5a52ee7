"""Every reachable state of a program, with every choice of its environment.

`search` goes through all states of a world, breadth first; `abstraction` and `kept` tell states of
a program apart; `user` is the world of a user's program, with `controller` as its surroundings.
"""
