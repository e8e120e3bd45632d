"""What people read: tables, pages, pictures, explanations, annotations."""
