"""From phases to heights and slopes with their errors, and flags for cells that hold no echo of their own."""
