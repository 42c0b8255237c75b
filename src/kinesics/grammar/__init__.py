"""What was moved, read as a language: motifs, phrases, symmetry classes, the motion graph ([Schultz2012] §3.2-3.6)."""
