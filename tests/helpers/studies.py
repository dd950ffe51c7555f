"""Constants of the tests of user studies."""

#: The models of the NPSS paper's study.
MODELS = ["VGRU-r1 (SA)", "MBR-unsup (SA)", "MBR-long", "VGRU-ac", "GRU-d", "VGRU-d"]
#: The first line of a file of votes.
HEADER = "action,question,sequence,model_a,model_b,participant,choice"
