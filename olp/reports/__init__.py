"""Output for users: tables, pages, pictures, explanations, annotations."""
