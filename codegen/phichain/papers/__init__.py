"""Both papers, figure by figure, from their scenes."""
