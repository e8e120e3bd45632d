"""What is seen and pressed; everything it does can be done without a screen as well."""
