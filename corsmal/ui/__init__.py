"""What the pages share: the choice in the address bar, cached calls, background jobs and components."""
