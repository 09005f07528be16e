"""Declared exercises: data instead of trusted code.

A declaration holds calls written in Python's notation, how inputs are drawn, what is compared and how, a solution and
known mistakes. The solution and the mistakes run behind the same walls as a student's program, in processes of their
own; the trusted side draws inputs, compares plain values, and words the verdict.
"""
