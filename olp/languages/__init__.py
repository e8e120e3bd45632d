"""What all robot languages share: the base of the writers and the host of the grammars."""
