"""What `seamap-rt validate` judges."""
