"""Generated C on emulated microcontrollers: the twenty points that firmware projects ask for, and what they cost."""
