"""What the check scripts share. Needs nothing installed unless a module says so."""
