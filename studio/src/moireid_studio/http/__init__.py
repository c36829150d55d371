"""What stands between the network and the routes.

connections.py  how many connections there are, and how long one may be silent
rates.py        how often a token may ask             shares.py  how many films it may have here
logs.py         the log, without names               metrics.py  figures for Prometheus
server.py       the studio's server, on a socket
"""
