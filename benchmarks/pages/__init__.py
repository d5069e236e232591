"""What becomes of measured tables: HTML pages, and the page of the documentation."""
