# The head of a file, a comment before a declaration, a comment behind a member.
1s|^// |/// \\file\n/// |
s|^( *)//( .*)?$|\1///\2|
s|([;,{}] *) // |\1 ///< |
