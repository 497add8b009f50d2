"""Requirements of graphs, and golden results, against what runs, loops and studies give."""
