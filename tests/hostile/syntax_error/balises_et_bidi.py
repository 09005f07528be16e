def repondre(contexte):
    "‮⁦<script>alert(1)</script>{{ 7*7 }}" [2J</pre>
