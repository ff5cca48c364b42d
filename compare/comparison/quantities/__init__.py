"""What a comparison looks at: fronts, edges, profiles, histories, places one by one."""
