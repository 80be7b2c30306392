"""The program form: named assignments, per kernel; reading listings back and comparing them."""
