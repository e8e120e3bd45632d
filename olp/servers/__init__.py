"""Programs that stay: language server, language service, assistants' server, stepping controller."""
