"""What turns an emitted folder into something that firmware projects take: drift against it, packages of their ecosystems."""

