"""Many copies of one robot and world, stepped together by MuJoCo Warp on a GPU or on the CPU."""
