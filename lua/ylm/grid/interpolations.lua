--- How a grid is looked up between its points: the names of all ways.
return { "hermite", "taylor", "linear" }
