"""Find out why a robot stands: the chain of causes from a waiting block to who has to act."""
