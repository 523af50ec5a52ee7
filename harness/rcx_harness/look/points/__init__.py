"""`rcx points`: back up points and other stored data of a controller, and restore them."""
