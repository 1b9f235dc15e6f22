"""`perimpm bench`: measured speed, beside peers and beside what the machine can do."""
