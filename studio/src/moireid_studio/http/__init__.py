"""What is between the network and the routes.

addresses.py    the studio's address in links that other people open
logs.py         the log, without names
metrics.py      figures for Prometheus
server.py       the studio's server, on a socket; rates of requests and places for films
"""
