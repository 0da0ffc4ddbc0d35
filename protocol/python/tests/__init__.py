"""Tests of hopes_client, with nothing but the standard library."""
