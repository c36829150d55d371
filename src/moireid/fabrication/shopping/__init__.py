"""What to buy for badges, and how to cut it.

cutting.py         pieces of lens sheet on whole sheets, by cuts from edge to edge
shopping_list.py   from a badge and a number of people to the lines of a shopping list
shopping_files.py  shopping-list.csv and cutting-plan.pdf
"""
