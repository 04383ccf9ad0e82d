"""What happens in a synthetic recording: people, containers, cameras and when things move."""
