"""How references are made: the dense engine in binary128, closed forms, heyoka in binary128, long chains in 80 bits."""
