"""Every reachable state of a program, with every choice of its environment, breadth first."""
