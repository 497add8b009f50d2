"""What has changed between two graphs, two runs or two studies."""
