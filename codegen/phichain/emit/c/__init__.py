"""Programs -> NAME.h and NAME.c."""
