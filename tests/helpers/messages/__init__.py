"""Random messages and requests for every interface of a running robot."""
