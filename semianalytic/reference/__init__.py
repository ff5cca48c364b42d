"""Answers to verify against: closed forms, prescribed slip, the algorithm of the article."""
