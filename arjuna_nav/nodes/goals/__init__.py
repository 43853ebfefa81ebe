"""Goals as the navigator receives, checks and stores them."""
