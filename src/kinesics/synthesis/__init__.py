"""New movement performed from recordings: transitions, the network of paths, its controller ([Schultz2012] §4.4)."""
