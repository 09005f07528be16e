"""Advice on a program that passes: what an engineer would write otherwise, each with the edit that does so."""
