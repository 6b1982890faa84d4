"""The studies' models."""
