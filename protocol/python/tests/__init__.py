"""Tests of hopes_client. They need only the standard library."""
