"""Every reachable state of a user's program, with his panel and a small controller around it.

`user` is the world of the program, with `controller` as its surroundings; `kept` says what of the
state of the library's blocks has an effect later.
"""
