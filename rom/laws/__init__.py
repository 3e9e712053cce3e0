"""Contact laws: rigid friction, Eq. (28), and elastic contacts that slide, vary and open.

friction.py has Tanh and Coulomb, joint_laws.py Jenkins and Iwan, frictional_contact.py normal
loads that vary, contacts.py groups of them; elements.py is how the core reads these, law_record.py
how files do, states.py what a contact does: stick, slip or open.
"""
