"""Reproduction of the article: its cases, its claims, and their judgement."""
