"""The stability report: what a study found, said in words, drawn and written down; nothing is computed here."""
