"""`mcsl report`: one page that a surgeon or an editor reads in a minute."""
