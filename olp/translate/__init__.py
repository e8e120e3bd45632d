"""From one language to another: what the target cannot say is brought into what it can, and told in a receipt."""
